"""Reads and writes the CSV files of turtlesim's recordings."""
import csv

COLUMNS = ['tick', 'event', 'x', 'y', 'theta', 'linear_velocity', 'angular_velocity', 'r', 'g', 'b']


def read(path):
    """Return the rows, as {column: text}."""
    with open(path, newline='', encoding='utf-8') as file:
        return list(csv.DictReader(file))


def write(path, rows):
    """Write rows, {column: value}."""
    with open(path, 'w', newline='', encoding='utf-8') as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
