"""The archive and what is made from it: certificates, archived runs solved again."""
