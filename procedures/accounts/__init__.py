"""Who is who: people with a role and a secret of their own, for the console and for signatures of results."""
