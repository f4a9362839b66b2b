"""What every test starts from."""

import signal

# a shell's background job is started deaf to SIGINT, and so would be what tests start
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
