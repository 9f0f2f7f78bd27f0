"""The fields of words in streams, in vectors and at the ports of a core, as Verilog."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from cordicc.backends.rtl.names import comment
from cordicc.backends.rtl.word_ports import PortWord


def byte_fields(ports: Sequence[PortWord]) -> Iterator[tuple[PortWord, int]]:
    """Yield the ports with their first bits in a stream: whole bytes each, the first port in the lowest."""
    at = 0
    for port in ports:
        yield port, at
        at += 8 * port.field_bytes


def bit_fields(ports: Sequence[PortWord]) -> Iterator[tuple[PortWord, int]]:
    """Yield the ports with their first bits in a vector of the bench: bit by bit, the first port lowest."""
    at = 0
    for port in ports:
        yield port, at
        at += port.width


def stream_texts(inputs: Sequence[PortWord], outputs: Sequence[PortWord]) -> Mapping[str, object]:
    """Return what the templates of stream and bench say of fields."""
    in_bits, out_bits = (sum(port.width for port in ports) for ports in (inputs, outputs))
    in_bytes, out_bytes = (sum(port.field_bytes for port in ports) for ports in (inputs, outputs))
    return {
        "in_bits": in_bits,
        "out_bits": out_bits + 1,
        "axis_in_bits": 8 * in_bytes,
        "axis_out_bits": 8 * out_bytes,
        "axis_in_fields": [_described(port, at) for port, at in byte_fields(inputs)],
        "axis_out_fields": [_described(port, at) for port, at in byte_fields(outputs)],
        "axis_core_inputs": [
            f".{port.port}({_bits('s_axis_tdata', at, port)})" for port, at in byte_fields(inputs)
        ],
        "bench_core_inputs": [f".{port.port}({_bits('words', at, port)})" for port, at in bit_fields(inputs)],
        "axis_out_words": _extended("shown", outputs),
        "bench_in_words": _extended("s_words", inputs),
        "bench_out_words": _extended("next_wanted", outputs),
        "in_order": _order(inputs),
        "out_order": ", ".join(["out_ok", *(port.port for port in reversed(outputs))]),
        "spare_bits": [
            f"s_axis_tdata[{at + 8 * port.field_bytes - 1}:{at + port.width}]"
            for port, at in byte_fields(inputs)
            if 8 * port.field_bytes > port.width
        ],
        "garbage": _noise(in_bits),
    }


def _order(ports: Sequence[PortWord]) -> str:
    return ", ".join(port.port for port in reversed(ports))


def _bits(signal: str, at: int, port: PortWord) -> str:
    return f"{signal}[{at + port.width - 1}:{at}]"


def _described(port: PortWord, at: int) -> str:
    """Return what a field is, for a comment."""
    return comment(f"[{at + 8 * port.field_bytes - 1}:{at}] {port.port}, {port.width} bits: {port.meaning}")


def _extended(signal: str, ports: Sequence[PortWord]) -> list[str]:
    """Return the words of a vector extended by their signs to whole bytes, the last port first."""
    texts = []
    for port, at in reversed(list(bit_fields(ports))):
        more, sign = 8 * port.field_bytes - port.width, f"{signal}[{at + port.width - 1}]"
        texts.append(f"{{{more}{{{sign}}}}}, {_bits(signal, at, port)}" if more else _bits(signal, at, port))
    return texts


def _noise(bits: int) -> str:
    """Return so many pseudo-random bits, from 32."""
    whole, rest = divmod(bits, 32)
    parts = [f"noise ^ 32'h{0x9E3779B9 * (at + 1) % 2**32:08x}" for at in range(whole)]
    return ", ".join([*parts, f"noise[{rest - 1}:0]"] if rest else parts)
