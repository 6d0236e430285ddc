"""Distributions, intervals, Monte Carlo, budgets and noise."""
