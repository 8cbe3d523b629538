"""What the servers for browsers share. A server imports from here:

    core.web, core.access       the HTTP server in a thread of its own, and who may connect
    websocket, bridge           WebSocket clients, and their access to ROS; core.session: the settings of a client
    sources, streams            image topics as video
    rosapi_answers              the answers of rosapi

The other modules are parts of these. ``core`` imports no ROS.
"""
