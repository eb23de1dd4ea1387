# For hosts that are not Debian 12. Not part of CI, and untested there.
#   docker build -t impedraw .
#   docker run --rm -v "$PWD/runs:/impedraw/runs" impedraw draw
FROM debian:12
RUN apt-get update && apt-get install -y --no-install-recommends ca-certificates git python3
WORKDIR /impedraw
COPY . .
# Installs Debian's packages and the wheels, and builds.
RUN ./impedraw --help >/dev/null
ENTRYPOINT ["./impedraw"]
