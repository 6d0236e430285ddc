"""What a journal says beside its dwells: the audit trail, devices, changes, lines, what was left out or taken back."""
