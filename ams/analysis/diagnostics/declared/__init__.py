"""What the readings contradict of what was declared or written down: axes, signs, order, fields, replications."""
