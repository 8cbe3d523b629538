#!/usr/bin/env bash
# Gradescope runs this once, as root, when it builds the image: installs the grader for all submissions.
set -eu
mkdir -p /opt/turtle_robotont
tar -xzf /autograder/source/turtle_robotont.tar.gz -C /opt/turtle_robotont
TURTLE_ROBOTONT_WS=/opt/turtle_robotont_ws /opt/turtle_robotont/run build
chmod -R a+rX /opt/turtle_robotont /opt/turtle_robotont_ws
