import hashlib

import numpy as np
import safetensors.numpy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from mapping.tensor_file import size_of, write_through

CONTENTS = st.dictionaries(
    st.text("abc.", min_size=1, max_size=9),
    st.sampled_from(("f4", "f8", "i4", "u1", "u8")).flatmap(
        lambda kind: arrays(kind, array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=5))
    ),
    max_size=6,
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(CONTENTS)
def test_the_library_reads_what_is_written_with_its_size_and_checksum(tmp_path, contents):
    path = tmp_path / "arrays"
    sha256 = write_through(path, contents)
    written = path.read_bytes()
    assert (len(written), hashlib.sha256(written).hexdigest()) == (size_of(contents), sha256)
    again = safetensors.numpy.load(written)
    assert again.keys() == contents.keys()
    for name, array in contents.items():
        assert again[name].dtype == array.dtype
        np.testing.assert_array_equal(again[name], array)


def test_no_piece_that_is_written_is_large(tmp_path, monkeypatch):
    pieces = []
    real = hashlib.sha256

    class Watched:
        def __init__(self):
            self._real = real()

        def update(self, piece):
            pieces.append(len(piece))
            self._real.update(piece)

        def hexdigest(self):
            return self._real.hexdigest()

    monkeypatch.setattr("mapping.tensor_file.hashlib.sha256", Watched)
    write_through(tmp_path / "arrays", {"rows": np.zeros((3_000_000, 1))})
    assert max(pieces) <= 1 << 20 and sum(pieces) > 24_000_000
