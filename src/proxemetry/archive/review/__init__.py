"""What people corrected: actions, the log, how they are applied, agreement of reviewers."""
