"""What runs tonight: one queue a rig, what people say about it, and the runner that starts what is due."""
