"""A run judged: its numbers held against what was asked, what they mean in words, and what failures come from.

The door is `judgement`: a `Run` in, its numbers (`summary`) and the sentences that they deserve (`remarks`) out.
"""
