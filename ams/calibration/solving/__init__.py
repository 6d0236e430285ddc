"""Axes solved side by side, by which model, and what that will come to before anything is measured."""
