"""Grades programs of students: exercise files, observation, rules, and reports. See rules/exercise.py."""
