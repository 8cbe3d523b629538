"""map_server: map files as topics and services, and map_saver, which writes them."""
