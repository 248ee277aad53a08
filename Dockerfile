FROM python:3.11-slim

# The one library that wheels (Pinocchio, fast-simplification) expect and this image lacks: OpenMP.
RUN apt-get update \
    && apt-get install --yes --no-install-recommends libgomp1 \
    && rm -rf /var/lib/apt/lists/*

WORKDIR /opt/llsrbm
COPY requirements.lock ./
RUN pip install --no-cache-dir --requirement requirements.lock
COPY pyproject.toml README.md LICENSE ./
COPY llsrbm llsrbm
COPY app app
COPY assets assets
RUN pip install --no-cache-dir --no-deps .

# A home of its own, because leg fits, meshes and solvers are cached there.
RUN useradd --create-home llsrbm
USER llsrbm
WORKDIR /home/llsrbm

EXPOSE 8080
# The first start computes the caches before the page answers.
HEALTHCHECK --interval=10s --timeout=5s --start-period=90s --retries=3 \
    CMD ["python", "-c", "import urllib.request; urllib.request.urlopen('http://127.0.0.1:8080/', timeout=4)"]
CMD ["llsrbm", "serve", "--host", "0.0.0.0", "--port", "8080"]
