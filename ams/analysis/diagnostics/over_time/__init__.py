"""What goes with time, with the order of the dwells and with the recorded temperature."""
