#!/bin/sh
# The RUSTC_WRAPPER of `make coverage`: counters for lines and branches in the crate `lcpstar` alone. Branches are an
# unstable option of the stable compiler.
case " $* " in
*" --crate-name lcpstar "* | *" --crate-name no_alloc"*)
  RUSTC_BOOTSTRAP=1 exec "$@" -Cinstrument-coverage -Zcoverage-options=branch
  ;;
*" --crate-name _core "*) exec "$@" -Cinstrument-coverage ;;
*) exec "$@" ;;
esac
