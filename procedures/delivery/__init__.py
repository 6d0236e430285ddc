"""What leaves a finished run: sets, archive, exports, report; and archived runs solved again."""
