"""What comes in: tables of observations, requests, uncertainties of the table and of what readings share."""
