"""ONNX Runtime as a small robot wants it: no telemetry, one thread, nothing spinning, weights mapped from disk."""

import os
from pathlib import Path

# Read when the library loads; later switches do not stop its sockets and thread.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")

import onnxruntime  # noqa: E402


def open_session(
    path: Path, threads: int = 1, exact: bool = False, frequent: bool = False
) -> onnxruntime.InferenceSession:
    """A CPU session of the graph at ``path``. External data stays mapped from its file and costs what is touched.

    ``frequent`` keeps the memory of activations from one pass to the next: for a graph that runs several times a second
    on inputs of one size, fresh pages cost a quarter of the pass. Others give it back.
    ``exact`` keeps float arithmetic where the graph states it: the runtime would otherwise join int8 weights and the
    products that use them into kernels that round the other factor to int8 as well.
    """
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.enable_cpu_mem_arena = frequent
    options.log_severity_level = 3
    if exact:
        options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_BASIC
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    options.add_session_config_entry("session.inter_op.allow_spinning", "0")
    return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
