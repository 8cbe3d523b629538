"""Messages of a publisher that come in any pieces, from a real socket, and the end of its connection."""
import asyncio
import socket

import pytest

from browser_servers.incoming import BUFFER_SIZE, Incoming

MESSAGES = [b'', b'a', b'x' * 1000, bytes(range(256)) * 2000, b'b' * (3 * BUFFER_SIZE), b'last']
STREAM = b''.join(len(one).to_bytes(4, 'little') + one for one in MESSAGES)


@pytest.mark.parametrize('first, step', [(0, len(STREAM)), (0, 5000), (3, 4999), (1009, 70000), (len(STREAM), 1)])
def test_messages_come_whole_and_in_order(first, step):
    async def work():
        ours, theirs = socket.socketpair()
        loop, came, ended = asyncio.get_running_loop(), [], asyncio.Event()
        Incoming(loop, ours, STREAM[:first], came.append, ended.set)
        theirs.setblocking(False)
        for begin in range(first, len(STREAM), step):
            await loop.sock_sendall(theirs, STREAM[begin:begin + step])
            await asyncio.sleep(0)
        theirs.close()
        await asyncio.wait_for(ended.wait(), 10.0)
        assert came == MESSAGES and ours.fileno() == -1
    asyncio.run(work())
