# Dray in a container: the wheel is built in one stage and installed in another, from the locks alone.
# The Python is the one for which the locks were resolved; pin it by digest with --build-arg, or PYTHON_IMAGE in .env.
ARG PYTHON_IMAGE=python:3.11-slim
FROM ${PYTHON_IMAGE} AS build
WORKDIR /src
COPY requirements-dev.txt ./
RUN pip install --no-cache-dir --require-hashes -r requirements-dev.txt
COPY . .
RUN python -m build --wheel --no-isolation --outdir /dist

FROM ${PYTHON_IMAGE}
# A number that does not change: whoever mounts a folder gives it to this user.
RUN useradd --system --uid 10001 --create-home --home-dir /var/lib/dray dray \
    && install --directory --owner dray --mode 700 /var/lib/dray/journals
COPY requirements.txt /tmp/
RUN pip install --no-cache-dir --require-hashes -r /tmp/requirements.txt
COPY --from=build /dist/ /tmp/dist/
RUN pip install --no-cache-dir --no-deps /tmp/dist/*.whl && rm -rf /tmp/dist /tmp/requirements.txt

USER dray
WORKDIR /var/lib/dray
ENV DRAY_DATABASE_URL=sqlite:////var/lib/dray/dray.db
EXPOSE 8000 8001
HEALTHCHECK --interval=10s --timeout=3s --start-period=20s \
    CMD ["python", "-c", "import urllib.request as u; u.urlopen('http://127.0.0.1:8000/readyz', timeout=2)"]
# Inside the container every address; which of the host's may reach it is said where it is published.
CMD ["dray", "up", "--host", "0.0.0.0", "--port", "8000"]
