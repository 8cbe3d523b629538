# An image with everything installed and built, for compose.yaml and .devcontainer: docs/installation.md says how to use it.
FROM debian:13

SHELL ["/bin/bash", "-euo", "pipefail", "-c"]
ENV LANG=C.UTF-8
# The number of the user stays, because a volume of an earlier image belongs to it.
# hadolint ignore=DL3008
RUN apt-get update \
 && apt-get install -y --no-install-recommends ca-certificates git less nano \
 && rm -rf /var/lib/apt/lists/* \
 && useradd --create-home --uid 1000 --shell /bin/bash student

# The Debian packages are a layer of their own, which a change of the course does not renew.
WORKDIR /workspaces/turtle_robotont
COPY tools tools
COPY requirements.txt .
RUN repo=$PWD bash -euc '. tools/workspace.bash; find_ros; install_packages' && rm -rf /var/lib/apt/lists/*

# Codespaces puts its checkout into this folder, too, and then uses the workspace that is built here.
COPY . .
ENV TURTLE_ROBOTONT_WS=/home/student/workspace/turtle_robotont
# The page listens where a published port leads; who comes from outside the container needs the token that it prints.
ENV TURTLE_ROBOTONT_ADDRESS=0.0.0.0
RUN PIP_NO_CACHE_DIR=1 ./run build \
 && "$TURTLE_ROBOTONT_WS/venv/bin/python3" -m compileall -q packages scripts src \
 && mkdir output \
 && chown -R student: /home/student output

USER student
EXPOSE 8000
CMD ["./run", "view", "--turtlesim"]
