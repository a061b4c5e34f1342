"""``python -m benchmarks.blind.coupons``."""

from support.hidden_coupon import PROTOCOLS

from benchmarks.blind.command import main
from benchmarks.blind.coupons import __doc__ as told
from benchmarks.blind.coupons.cases import COUNTS
from benchmarks.blind.coupons.run import bench

if __name__ == "__main__":
    main("coupons", told or "", COUNTS, tuple(PROTOCOLS), bench)
