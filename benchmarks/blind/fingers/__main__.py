"""``python -m benchmarks.blind.fingers``."""

from benchmarks.blind.command import main
from benchmarks.blind.fingers import __doc__ as told
from benchmarks.blind.fingers.cases import COUNTS, bench
from benchmarks.blind.fingers.finger import PROTOCOLS

if __name__ == "__main__":
    main("fingers", told or "", COUNTS, tuple(PROTOCOLS), bench)
