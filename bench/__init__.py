"""Speed and memory beside what a user would otherwise pick: ``python -m bench`` measures all and prints one table."""
