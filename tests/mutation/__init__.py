"""One mutation for each capability: the public thing is broken, and a test that names the capability must fail.

    python -m tests.mutation --parts 03 04 --shard 1/4   # breaks, runs, lists survivors; exit 1 if there are any
    python -m tests.mutation --trace --parts 03          # proposes the public things, for targets.toml

`targets.toml` says for each capability which public thing is broken. How it is broken: what it returns is perturbed,
and an error that it raises is swallowed (mutants.py).
"""
