# Measures photos without a Python installation: see docs/install.md.
FROM python:3.11-slim
# lensfun, the database of cameras and lenses, needs GLib, which a slim image lacks.
RUN apt-get update && apt-get install -y --no-install-recommends libglib2.0-0 && rm -rf /var/lib/apt/lists/*
WORKDIR /proxemetry
COPY requirements.lock pyproject.toml README.md LICENSE NOTICE ./
COPY src src
RUN pip install --no-cache-dir --require-hashes --only-binary :all: -r requirements.lock \
    && pip install --no-cache-dir --no-deps . \
    && useradd --create-home researcher
USER researcher
RUN proxemetry models fetch
ENTRYPOINT ["proxemetry"]
CMD ["--help"]
