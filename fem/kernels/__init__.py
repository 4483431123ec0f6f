"""What runs in the time loop: numba over plain arrays. Each module says what it holds; `jit`: how all is compiled."""
