"""What a solution says: replication, variance over the design, budget, predictions, advice, causes of residuals."""
