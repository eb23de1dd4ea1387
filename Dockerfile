# For hosts that are not Debian 12. Not part of CI, and untested there.
#   docker build -t impedraw .
#   docker run --rm -v "$PWD/runs:/impedraw/runs" impedraw draw
# Debian 12 of 18 September 2026, by the digest that docker-library/repo-info lists.
FROM debian:bookworm-20260918@sha256:f37a335e82bca302e955fa39f9dfe28f1be618f016f8a2b56318e5a5111afc26
RUN apt-get update && apt-get install -y --no-install-recommends ca-certificates git python3
WORKDIR /impedraw
COPY . .
# Installs Debian's packages and the wheels, and builds.
RUN ./impedraw --help >/dev/null
ENTRYPOINT ["./impedraw"]
