# expected: failed: 0: none
../square_by_topics/right_four_positions.py
