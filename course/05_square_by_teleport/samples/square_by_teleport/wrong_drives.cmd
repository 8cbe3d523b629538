# expected: failed: 0: none
../../../04_square_by_topics/square_by_topics.py
