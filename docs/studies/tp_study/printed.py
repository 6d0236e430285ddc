"""What TP prints: table 2, with the misprints that the other columns of the same row expose put right.

All σ in units of 1e-4 degrees, as in the table. Source: TP table 2, pages 47 and 48 of the report.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One sensor axis of one calibration."""

    figure: str
    points: int
    """K. Where the table's own count does not fit its F or the design in the text: that of the text."""
    replications: int
    parameters: int
    sigma_e: float
    sigma_bias: float
    sigma_prec: float
    t_bias: float
    sigma_b: float
    sigma_s: float
    t_b: float
    t_s: float
    remark: str = ""


ROWS = {
    row.figure: row
    for row in (
        Row("22", 73, 6, 3, 1.60, 0.431, 1.54, 0.407, 1.69, 0.347, 5.82, 0.245, "K printed 325, F fits 73"),
        Row("24", 145, 6, 3, 3.17, 2.62, 1.79, 11.0, 0.955, 0.622, 0.124, 0.060, "K printed 325, F fits 145"),
        Row("26", 4, 6, 3, 2.84, 2.20, 1.79, 30.0, 0.940, 0.698, 0.052, 0.029),
        Row("28(a)", 325, 6, 4, 7.76, 3.54, 6.90, 1.33, 41.0, 123.0, 102.0, 919.0, "σ_S printed 1.23, T_S fits 123"),
        Row("28(b)", 325, 6, 4, 3.87, 3.54, 1.56, 26.2, 24.0, 8.22, 44.0, 5.14),
        Row("34", 325, 6, 4, 16.6, 2.45, 16.4, 0.113, 281.0, 145.0, 5850.0, 1570.0, "σ_prec, σ_S printed 1.64, 1.45"),
        Row("35", 53, 6, 4, 4.27, 3.97, 1.54, 36.2, 9.35, 3.96, 5.01, 0.899),
        Row("37", 325, 4, 4, 4.89, 4.71, 1.31, 39.4, 13.4, 4.70, 7.66, 0.944),
        Row(
            "42",
            325,
            4,
            4,
            14.2,
            4.17,
            13.5,
            0.289,
            170.0,
            201.0,
            717.0,
            1000.0,
            "remark says 6 replications, F fits 4",
        ),
        Row("44(a)", 247, 6, 4, 4.34, 4.10, 1.42, 42.1, 12.5, 17.5, 9.08, 17.8),
        Row("44(b)", 247, 6, 4, 4.44, 4.17, 1.54, 37.3, 15.2, 5.79, 12.8, 1.84),
        Row("44(c)", 247, 6, 4, 3.55, 3.11, 1.71, 16.8, 8.10, 22.0, 6.36, 46.9),
        Row("47(a)", 481, 6, 4, 4.09, 3.72, 1.71, 23.9, 14.7, 33.2, 15.0, 76.7),
        Row("47(b)", 481, 6, 4, 5.23, 5.08, 1.23, 85.9, 8.96, 8.96, 2.98, 2.98),
        Row("47(c)", 481, 6, 4, 4.79, 4.28, 2.15, 20.0, 23.2, 33.0, 27.0, 54.6),
        Row("50 x", 6, 6, 4, 4.33, 4.06, 1.70, 85.0, 1.29, 3.15, 0.037, 0.223),
        Row("50 y", 6, 6, 4, 1.97, 1.50, 1.33, 19.1, 1.76, 1.48, 0.435, 0.305),
        Row("50 z", 6, 6, 4, 2.79, 1.34, 2.50, 4.28, 3.26, 4.60, 1.87, 3.72),
        Row("53 x", 73, 6, 4, 4.12, 3.78, 1.65, 27.3, 5.61, 12.3, 2.03, 9.73),
        Row("53 y", 73, 6, 4, 5.64, 5.51, 1.23, 104.0, 3.74, 3.34, 0.43, 0.34),
        Row("53 z", 73, 6, 4, 4.79, 4.23, 2.24, 18.5, 8.53, 13.5, 3.52, 8.89, "σ_S printed 1.35, T_S fits 13.5"),
    )
}

SIGMA_INVERSE_22 = 1.74
"""Root mean square of the inferred pitch of figure 23. Source: TP 9.1."""

TABLE_1 = {
    "2(a)": (1.989, None),
    "2(b)": (1.993, 1.927),
    "2(c)": (2.008, 2.222),
    "2(d)": (1.993, 2.174),
    "3, top": (2.127, 1.811),
    "3, bottom": (1.937, 1.834),
    "4": (1.941, 1.912),
    "5": (1.989, None),
}
"""Figure to (V^½, V_R^½)."""
