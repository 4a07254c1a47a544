"""The review page: check every photo's numbers, correct what is wrong, report how well two people agree.

It answers this machine alone, asks nothing of any other, and never writes to a photo.
"""
