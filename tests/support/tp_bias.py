"""TP's test of bias from the columns that its table 2 prints, by hand."""

from scipy.stats import f


def t_bias(sigma_bias: float, sigma_prec: float, points: int, replications: int, parameters: int) -> float:
    """Return T_bias from the printed columns of TP table 2, any common unit."""
    mean_square_bias = sigma_bias**2 * replications * points / (points - parameters)
    mean_square_precision = sigma_prec**2 * replications / (replications - 1)
    return mean_square_bias / mean_square_precision


def f_bias(points: int, replications: int, parameters: int) -> float:
    """Return F(K − L, K(n − 1)) at 95 %, which T_bias is held against."""
    return float(f.ppf(0.95, points - parameters, points * (replications - 1)))
