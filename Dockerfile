# docker build -t dolfingrip .
# docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/work" dolfingrip dolfingrip demo

# The environment alone, in which scripts/run works on a mounted checkout.
FROM debian:trixie-slim AS environment
ARG PIP_INDEX_URL PIP_EXTRA_INDEX_URL
# c[a]: a host with a certificate bundle of its own puts it into the build context as "ca".
COPY scripts/provision scripts/requirements.lock c[a] /opt/recipe/
RUN /opt/recipe/provision
ENV PATH=/opt/venv/bin:/usr/local/bin:/usr/bin:/bin

# With the project installed.
FROM environment
COPY . /opt/dolfingrip
RUN python -m pip install --no-cache-dir --disable-pip-version-check --no-deps \
        --no-build-isolation /opt/dolfingrip \
    && install -D -t /usr/local/lib/dolfingrip /opt/dolfingrip/scripts/enter /opt/dolfingrip/scripts/cache \
    && rm -rf /opt/dolfingrip \
    # Any --user works: its home, with its compiled forms, and its work have a place it may write to.
    && install -d -m 1777 /work /home/dolfingrip
ENV HOME=/home/dolfingrip
WORKDIR /work
USER 1000:1000
ENTRYPOINT ["/usr/local/lib/dolfingrip/enter"]
CMD ["dolfingrip", "--help"]
