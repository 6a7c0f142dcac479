"""Pictures of plans and runs. Knows matplotlib, and loads it only when a picture is drawn."""
