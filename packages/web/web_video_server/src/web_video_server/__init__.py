"""web_video_server: image topics as video in a browser."""
