"""Where the console is served when nobody says otherwise; known without the libraries that serve it."""

DEFAULT_LISTEN = "127.0.0.1:8600"
