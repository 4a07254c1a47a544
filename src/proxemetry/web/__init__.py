"""The review page: look at every photo's numbers, put right what is wrong, publish how well two people agree.

It answers this machine alone, asks nothing of any other, and never writes to a photo.
"""
