"""The solvers: linear form, Gauss-Newton, mixed model, joint fit."""
