"""What runs in a thread beside a block."""

import threading
from contextlib import contextmanager


@contextmanager
def beside(work):
    """Run `work`, which is given an event that is set when the block is over."""
    over = threading.Event()
    thread = threading.Thread(target=work, args=(over,))
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
