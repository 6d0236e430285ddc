"""The command: where it begins and how it speaks; its subcommands stand in rooms by the headings of `--help`."""
