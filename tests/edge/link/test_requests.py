import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from edge.link import requests
from edge.link.requests import Array, RequestError, pack, unpack

DTYPES = ["bool", "int8", "uint8", "int16", "uint16", "int32", "int64", "float32", "float64"]


@given(st.sampled_from(DTYPES).flatmap(lambda d: hnp.arrays(d, hnp.array_shapes(min_dims=0, max_dims=4, min_side=0))))
def test_arrays_there_and_back(array):
    back = unpack(Array, pack(Array.of(array))).numpy()
    assert back.dtype == array.dtype and back.shape == array.shape
    np.testing.assert_array_equal(back, array)


def test_arrays_travel_little_endian_row_by_row():
    array = np.array([[1, 2], [3, 4]], ">i2").T
    assert Array.of(array).data == b"\1\0\3\0\2\0\4\0"
    np.testing.assert_array_equal(Array.of(array).numpy(), array)


@pytest.mark.parametrize(
    "kind, body, field",
    [
        (requests.Find, {}, "object"),
        (requests.Find, {"object": ""}, "object"),
        (requests.Find, {"object": " \t"}, "object"),
        (requests.Find, {"object": 3}, "object"),
        (requests.Find, {"object": "x" * 201}, "object"),
        (requests.Find, {"object": "cup", "search_unknwon": True}, "search_unknwon"),
        (requests.Search, {"object": "cup", "k": 0}, "k"),
        (requests.EmbedText, {"texts": [], "digest": ""}, "texts"),
        (requests.EmbedText, {"texts": ["a", 5], "digest": ""}, "texts[1]"),
        (requests.EmbedTextReply, {"vectors": {"dtype": "float32", "shape": [2, 3], "data": b"1234"}}, "vectors"),
        (requests.EmbedTextReply, {"vectors": {"dtype": "object", "shape": [1], "data": b"1"}}, "vectors.dtype"),
        (requests.EmbedTextReply, {"vectors": {"dtype": "int8", "shape": [-1], "data": b"1"}}, "vectors.shape[0]"),
        (requests.EmbedTextReply, {"vectors": {"dtype": "int8", "data": b"1"}}, "vectors.shape"),
    ],
)
def test_a_bad_body_names_the_field(kind, body, field):
    with pytest.raises(RequestError) as caught:
        unpack(kind, msgspec.msgpack.encode(body))
    assert caught.value.field == field
    assert field.split(".")[-1].split("[")[0] in str(caught.value)


@given(st.binary(max_size=60))
def test_noise_is_refused_and_never_raises_otherwise(payload):
    for kind in (requests.Find, requests.GraphReply, Array):
        try:
            unpack(kind, payload)
        except RequestError:
            pass


def test_a_shape_that_lies_about_its_size_takes_no_memory():
    body = {"dtype": "float64", "shape": [2**40, 2**40], "data": b""}
    with pytest.raises(RequestError, match="bytes"):
        unpack(Array, msgspec.msgpack.encode(body))
