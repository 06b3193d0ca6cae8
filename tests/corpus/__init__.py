"""Robot files as their makers publish them: a manifest, a command that fetches, loads and compares them.

python -m tests.corpus run --mirror FOLDER --format mjcf --output FIGURES
"""
