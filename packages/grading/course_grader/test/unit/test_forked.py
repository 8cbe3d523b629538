"""course_grader.attempt.forked: the threads of the master that notify nodes."""
import queue
import threading

from course_grader.attempt.forked import WakingPool

LONG = 20.0  # [s]


def test_tasks_begin_at_once_and_those_of_one_node_one_after_the_other():
    pool, began, goes_on = WakingPool(3), queue.Queue(), threading.Event()

    def task(name):
        began.put(name)
        goes_on.wait(LONG)
    for node, name in (('/one', 'first of one'), ('/one', 'second of one'), ('/two', 'first of two')):
        assert pool.queue_task(node, task, (name,))
    assert {began.get(timeout=LONG), began.get(timeout=LONG)} == {'first of one', 'first of two'}
    assert began.empty()
    goes_on.set()
    assert began.get(timeout=LONG) == 'second of one'
    pool.set_thread_count(0)
