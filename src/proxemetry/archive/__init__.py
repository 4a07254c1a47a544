"""Many photos: a frozen list of them, shards as units of work, one Parquet part a shard, tables made from the parts.

A part is written to a temporary file, synced and renamed, so that its existence is the ledger: a run that was
stopped in any way continues with the shards whose part is not there, and every photo has exactly one row.
"""
