"""The child process of a worker in which native runs draw: python -m impedraw.sweep.native_child

It reads requests from its standard input and answers on its standard output: pickles, each after its
length in eight bytes. The first answer says that the package is there. What goes wrong with a
run is its answer; a signal or a lack of memory ends the process, which the worker notices.
"""

import os
import pickle
import signal
import struct
import sys
import time
from typing import Any, BinaryIO

LENGTH = struct.Struct("<Q")


def send(stream: BinaryIO, value: Any) -> None:
    text = pickle.dumps(value)
    stream.write(LENGTH.pack(len(text)) + text)
    stream.flush()


def main() -> None:
    requests = sys.stdin.buffer
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever else prints is no answer
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the driver's
    from impedraw import _runner

    send(answers, "ready")
    while head := requests.read(LENGTH.size):
        request = pickle.loads(requests.read(LENGTH.unpack(head)[0]))
        try:
            if fault := request.pop("fault", None):
                _fail(fault)
            answer = {"result": _runner.run(**request)}
        except ValueError as error:
            answer = {"refused": str(error)}
        except MemoryError:
            answer = {"memory": True}
        except Exception as error:  # noqa: BLE001: of one run alone
            answer = {"error": f"{type(error).__name__}: {error}"}
        send(answers, answer)


def _fail(how: str) -> None:
    """For tests: what a fault of the program would do."""
    if how == "hang":
        time.sleep(3600)
    elif how == "memory":
        held = []
        while True:
            held.append(bytearray(10**8))
    else:
        os.kill(os.getpid(), signal.Signals[how])


if __name__ == "__main__":
    main()
