# The designer in a container:
#     docker build -t llsrbm .
#     docker run --rm -p 127.0.0.1:8080:8080 llsrbm
# and open the address that it prints. Published like this, only the machine it runs on reaches it;
# `-p 8080:8080` publishes it to the whole network. Inside, the server cannot know which of them it
# is and listens on all addresses, so it needs its token in both cases. To choose one that survives
# restarts, or none:
#     docker run --rm -p 127.0.0.1:8080:8080 llsrbm llsrbm serve --host 0.0.0.0 --token TOKEN|none
# Reached under a name (jumps.example), it has to know it: --allow-host jumps.example.
FROM python:3.11-slim

# OpenMP, which wheels (Pinocchio, fast-simplification) expect and this image lacks; and a C
# compiler, with which solvers become two to three times as fast (docs/architecture.md).
RUN apt-get update \
    && apt-get install --yes --no-install-recommends gcc libc6-dev libgomp1 \
    && rm -rf /var/lib/apt/lists/*

WORKDIR /opt/llsrbm
COPY requirements.lock ./
RUN pip install --no-cache-dir --requirement requirements.lock
COPY pyproject.toml README.md LICENSE ./
COPY llsrbm llsrbm
COPY app app
COPY assets assets
# `--build-arg EXTRAS=sweep` for the scheduler and the workers of a cluster.
ARG EXTRAS=
RUN pip install --no-cache-dir --no-deps . \
    && if [ -n "$EXTRAS" ]; then pip install --no-cache-dir ".[$EXTRAS]"; fi

# A home of its own, because leg fits, meshes and solvers are cached there.
RUN useradd --create-home llsrbm
USER llsrbm
WORKDIR /home/llsrbm

EXPOSE 8080
# The first start computes the caches before the page answers. That it asks for its token, 401, is
# an answer too.
HEALTHCHECK --interval=10s --timeout=5s --start-period=90s --retries=3 \
    CMD ["python", "-c", "import http.client; c = http.client.HTTPConnection('127.0.0.1', 8080, timeout=4); c.request('GET', '/'); raise SystemExit(c.getresponse().status not in (200, 401))"]
CMD ["llsrbm", "serve", "--host", "0.0.0.0", "--port", "8080"]
