"""When steps are due, timers that ignore stalls of the machine, idle threads, recordings."""
