"""What every simulator shares under ROS.

* ``clock``: SimulatorClock paces the steps, publishes /clock and ~clock_status, and has the services of time.
  ``lockstep`` and ``subscriber_backlog`` find out whether other nodes keep up.
* ``frame_services``: services that are answered between two steps. ``recording``: RecordedWorld, a world that threads
  share, and ~record.
* ``gazebo_services``, ``robotont_messages``, ``camera_topics``, ``distances``: interfaces that several simulators have.
* ``single_world``, ``launch_parameters``: what a second world in a namespace must not disturb. ``parent_link``: the
  program that owns the simulator's time.
"""
