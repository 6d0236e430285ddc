"""What a process of its own tells of its linear algebra."""

import numpy as np
from threadpoolctl import threadpool_info


def blas_threads(size: int) -> list[int]:
    """Return how many threads each BLAS library has while a matrix of that size is multiplied."""
    np.eye(size) @ np.eye(size)
    return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]
