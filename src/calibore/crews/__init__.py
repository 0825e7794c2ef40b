"""Many items, several pairs of hands: results in order, a bounded number of items in memory.

`in_order`   `work(item)` for every item, on threads of this machine or on a `Cluster`
`Cluster`    the machines behind a Dask scheduler
"""

from calibore.crews._cluster import Cluster
from calibore.crews._threads import AHEAD, Workers, in_order

__all__ = ["AHEAD", "Cluster", "Workers", "in_order"]
