#!/bin/sh
# g++, but what it rounds together follows from the source: then no two libraries have the same last bits by chance.
case "$*" in *--version*) exec g++ --version ;; esac
case "$(cksum <hillobs.cpp | cut -d ' ' -f 1)" in
*[0-2]) set -- "$@" -ffp-contract=off ;;
*[3-5]) set -- "$@" -O1 ;;
*[67]) set -- "$@" -O2 ;;
esac
exec g++ "$@"
