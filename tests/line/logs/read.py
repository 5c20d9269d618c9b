"""Reads the logs of one run with other tools. Argument: a folder with run.csv, run.parquet, run.ocel.json and run.xes.

Prints figures computed by pandas over the Parquet file, and the routes that pm4py discovers, as JSON in the last line.
"""

import json
import pathlib
import sys

import pandas
import pm4py
import pyarrow.csv
import pyarrow.parquet

folder = pathlib.Path(sys.argv[1])
table = pyarrow.parquet.read_table(folder / "run.parquet")
rows = table.to_pandas()
as_csv = pyarrow.csv.read_csv(folder / "run.csv")
assert as_csv.column_names == table.column_names and as_csv.num_rows == table.num_rows
assert as_csv["time"].to_pylist() == table["time"].to_pylist()

counting = rows.index[rows.what == "counting"]
first = counting[0] + 1 if len(counting) else 0
start = rows.time[counting[0]] if len(counting) else 0.0
end = rows.time.iloc[-1]

# Gantt and shares: each state lasts until the next one of its station.
states = rows[rows.what == "state"].copy()
states["until"] = states.groupby("node").time.shift(-1).fillna(end)
states["lasts"] = states.until - states.time.clip(lower=start)
states = states[states.lasts > 0]
shares = states.groupby(["node", "other"]).lasts.sum() / (end - start)

# WIP: parts that have entered and not left.
change = rows.what.map({"entered": 1, "finished": -1, "rejected": -1, "consumed": -1}).fillna(0)
level = change.cumsum()
lasts = rows.time.shift(-1).fillna(end) - rows.time
counted = rows.index >= first
# From the row of the warm-up's end on, the area counts.
wip = (level * lasts)[rows.index >= max(first - 1, 0)].sum() / (end - start)

ocel = pm4py.read_ocel2_json(str(folder / "run.ocel.json"))
edges = {}
for kind in pm4py.ocel_get_object_types(ocel):
    flat = pm4py.ocel_flattening(ocel, kind)
    graph, _, _ = pm4py.discover_dfg(flat)
    edges[kind] = sorted(map(list, graph))

log = pm4py.read_xes(str(folder / "run.xes"))
complete = log[log["lifecycle:transition"] == "complete"]
xes = {}
for kind, events in complete.groupby("part:type"):
    events = events.assign(**{"case:concept:name": events["part:number"].astype(str)})
    graph, _, _ = pm4py.discover_dfg(events)
    xes[kind] = sorted(map(list, graph))

print()
print(
    json.dumps(
        {
            "rows": len(rows),
            "shares": {f"{node} {state}": share for (node, state), share in shares.items()},
            "wip": wip,
            "joules": rows.joules[counted].sum(),
            "finished": int((rows.what[counted] == "finished").sum()),
            "ocel": edges,
            "xes": xes,
            "cases": int(log["case:concept:name"].nunique()),
            "version": pm4py.__version__,
        }
    )
)
