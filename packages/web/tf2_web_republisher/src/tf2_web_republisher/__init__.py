"""tf2_web_republisher: transforms for web pages."""
