"""The program itself: its interpreter, threads, memory, signals, log and compiled kernels."""
